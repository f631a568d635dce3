"""Texts of figures."""


def legend_texts(axes):
    """Entries of the legend of axes, from top to bottom."""
    return [text.get_text() for text in axes.get_legend().get_texts()]
