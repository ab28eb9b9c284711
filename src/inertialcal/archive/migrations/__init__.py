"""Changes of the schema, each with its way back; Alembic runs them."""
