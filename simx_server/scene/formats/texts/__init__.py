"""Values of annotations that are small languages."""
