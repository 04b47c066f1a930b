"""What heads and what they wear are painted with: albedo, and the pictures it is made of."""
