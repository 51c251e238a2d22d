"""``simx compare``: a program against the original and here, and the first quantity that departs."""
