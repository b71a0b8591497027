"""HTML pages that need nothing but themselves: templates and their rendering."""
