"""Alembic runs the migrations on the connection that `sigmatau.lab.store.connect` gives."""

from alembic import context

from sigmatau.lab.store.tables import metadata

connection = context.config.attributes["connection"]
context.configure(connection=connection, target_metadata=metadata, render_as_batch=True)
context.run_migrations()
