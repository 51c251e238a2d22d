"""What calls, batches, steps and streams cost."""
