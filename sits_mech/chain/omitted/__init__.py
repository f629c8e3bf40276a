"""What an answer leaves out, with its size: bending of the target, conductors far away, all of the mechanics."""
