"""Many chains: parameters that vary, methods side by side, results in one labelled dataset."""
