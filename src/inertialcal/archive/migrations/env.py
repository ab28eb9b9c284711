"""What Alembic runs: the steps between two versions, on the connection and in the transaction that are given."""

from alembic import context

context.configure(connection=context.config.attributes["connection"], render_as_batch=True)
context.run_migrations()
