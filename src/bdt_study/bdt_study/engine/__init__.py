"""Many jobs, whatever they are, on this computer or many, and a folder for what they give."""
