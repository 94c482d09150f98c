"""The paper's claims as experiments: tools/reproduce."""
