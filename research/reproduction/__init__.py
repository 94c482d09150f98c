"""The paper's claims as experiments: research/reproduce."""
