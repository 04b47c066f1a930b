"""What is computed for every new light: inputs of SS and composition, and what is done with their results."""
