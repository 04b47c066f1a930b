"""What heads wear, hair and raised arms included: opaque meshes that follow every head."""
