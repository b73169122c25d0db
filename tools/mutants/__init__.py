"""A mutation run: how much of what the code says do its neighbouring tests hold?

``python -m tools.mutants`` changes one place of the source at a time (`candidates`), runs the tests
that reach it (`reach`), and lists the changes that no test notices. Nothing of the checkout is
touched: each worker has a copy.
"""
