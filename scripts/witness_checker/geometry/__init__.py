"""What the surface is, exactly: integers and fractions on the very doubles of the file."""
