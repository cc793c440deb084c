"""Things that several tasks, or one crowded one, build from: shapes and how they collide."""
