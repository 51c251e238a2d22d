"""The thread that renders all images: requests, their queue, shared work, and the renderer in use."""
