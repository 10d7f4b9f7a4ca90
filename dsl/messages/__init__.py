"""Messages to an author: sources, places in them, diagnostics, and the one renderer.

Takes mistakes as data. Gives text with a framed excerpt, or JSON.
"""
