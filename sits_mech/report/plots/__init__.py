"""Plot what tables and searches hold; what a sensor looks like is drawn in `pictures`."""
