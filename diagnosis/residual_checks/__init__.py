"""What a fit leaves: where it exceeds the noise, what it goes with, and how loud it is."""
