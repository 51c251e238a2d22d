"""Images that several sensors share: those of one place, and those of one place in colours and in codes."""
