"""Files for the operator: images, films and state logs of a run."""
