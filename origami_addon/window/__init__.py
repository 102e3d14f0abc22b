"""Everything that the add-on shows in the window: panels, menus, colours over the 3D view, texts."""
