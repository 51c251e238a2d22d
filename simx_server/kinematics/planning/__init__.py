"""Search for paths and configurations: state spaces, validity, tasks."""
