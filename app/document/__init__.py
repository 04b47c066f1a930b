"""The user's work as plain records: what was set, its history, and its files. Knows no window and no thread."""
