"""Parts of the render thread: the queue, the images and states that requests share, a second thread."""
