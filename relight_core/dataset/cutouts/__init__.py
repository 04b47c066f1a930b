"""The samples of the person network: people cut out and put before scenes."""
