"""Training in stages: losses, warm-up, fine-tuning."""
