"""``simx status``: health and metrics of servers, for people, for programs and for Prometheus."""
