"""What people take elsewhere: models, arrays, drawings."""
