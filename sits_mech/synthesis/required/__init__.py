"""What is asked of a sensor: figures by name, requirements as files hold them, the space of designs."""
