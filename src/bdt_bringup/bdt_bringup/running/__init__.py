"""Starting the nodes, watching them, recording what they say."""
