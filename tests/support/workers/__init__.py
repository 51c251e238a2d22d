"""The traffic between xdist and its workers, which takes longer than many tests."""
