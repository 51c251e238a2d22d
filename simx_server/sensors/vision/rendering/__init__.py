"""What the render thread consists of: the queue, the images and states that requests share, a second thread."""
