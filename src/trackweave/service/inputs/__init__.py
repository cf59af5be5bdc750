"""Where reports come from: each input decodes in a process of its own."""
