"""Parts of scenes as specs: the objects that are copied, and what adds them to a scene."""
