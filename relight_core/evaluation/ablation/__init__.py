"""The paper's ablation (section 5.1, Table 2), and ours past it, all trained alike."""
