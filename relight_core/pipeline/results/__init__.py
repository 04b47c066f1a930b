"""What comes out: channels for a viewer, a finished picture for a file or a screen, layers for an editor."""
