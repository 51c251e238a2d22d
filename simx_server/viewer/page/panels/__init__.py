"""One file per tab. Each panel makes its elements when it is made, and updates them when new data comes."""
