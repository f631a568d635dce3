"""Laboratory sheets of a chain: predictions, columns for readings, tasks and answers.

- `sheet`: the sheet and its simulations; `first_pulse`: the first pulse on a wall;
- `similarity`: whether forces are a power of the speed;
- `row`: the row in words; `kinds`: columns;
- `losses`: its laws of loss in words;
- `sketch`: a sketch of the row;
- `answers`: the page for the teacher;
- `pages`: the sheet as HTML and Markdown.
"""
