"""The `relight` command: one module for each subcommand."""
