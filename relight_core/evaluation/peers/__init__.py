"""What others have published, restated from their papers to be measured against (paper, Table 3)."""
