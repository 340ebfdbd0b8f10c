from lidardraft.drafting.text.layout import layout_from_text as layout_from_text
