"""What is seen from where: item buffer, measures of views, best view, tour, view set, molecules."""
