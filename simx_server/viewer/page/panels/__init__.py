"""One file a tab. Each makes its elements when it is made, and brings them up to date when there are news."""
