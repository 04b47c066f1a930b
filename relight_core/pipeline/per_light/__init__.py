"""What every new light asks for: what SS and composition are told, and what is done to their answers."""
