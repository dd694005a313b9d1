// Nothing: the target that this file belongs to holds the precompiled headers of all rooms.
