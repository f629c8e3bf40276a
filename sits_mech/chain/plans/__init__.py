"""What a request will take and what its error will be, before it is solved."""
