"""Words of a figure that find their place: powers of ten in the labels, titles over the panels."""
import re

LETTER = 0.075  # inches: width of a letter of a title or a label


def with_power(label, power):
    """A label whose unit has a power of ten: 'flux (m/s)' and 4 give 'flux ($10^{4}$ m/s)'."""
    factor, depth = f"$10^{{{power}}}$", 0
    if label.endswith(")"):
        for k in range(len(label) - 1, -1, -1):
            depth += (label[k] == ")") - (label[k] == "(")
            if depth == 0:
                return f"{label[:k + 1]}{factor} {label[k + 1:]}"
    return f"{label} ({factor})" if label else factor


def fold_powers(figure):
    """Moves the power of ten that matplotlib writes at the end of an axis, under titles and beside labels, into the label. Called
    when all is drawn."""
    figure.draw_without_rendering()
    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis):
            found = re.fullmatch(r"1e([-+]?\d+)", axis.offsetText.get_text().replace("\u2212", "-"))
            named = axis.get_label_text()
            if found and (named or not axis.get_major_ticks()[0].label1.get_visible()):  # without numbers it tells nothing
                axis.offsetText.set_visible(False)
            if found and named:
                axis.set_label_text(with_power(axis.get_label_text(), int(found.group(1))))


def thin_labels(figure):
    """Where the names of ordinates of panels below each other overlap, as of long thin domains, the middle panel alone keeps its
    own."""
    named = [axes for axes in figure.axes if not getattr(axes, "is_bar", False) and axes.get_ylabel()]
    for label in {axes.get_ylabel() for axes in named}:
        alike = sorted((axes for axes in named if axes.get_ylabel() == label), key=lambda axes: axes.get_position().y0)
        boxes = [axes.yaxis.label.get_window_extent() for axes in alike]
        if any(one.overlaps(other) for one, other in zip(boxes, boxes[1:])):
            for axes in alike:
                axes.set_ylabel(label if axes is alike[len(alike) // 2] else "")


def plain(text):
    """A label without the signs of its formulas, as long as it is on paper."""
    return re.sub(r"[$^{}\\]", "", text)


def fit_label(axes, label, inches):
    """The label of the ordinate, in two lines where one is longer than the axis."""
    if "\n" not in label and LETTER * len(plain(label)) > inches:
        label = label.replace(" (", "\n(", 1)
    axes.set_ylabel(label)


def centre(figure, text):
    """Moves a title of the figure over the middle of its panels (all axes but colour bars), as far as it stays in the picture."""
    boxes = [axes.get_position() for axes in figure.axes if not getattr(axes, "is_bar", False)]
    if not boxes:
        return
    middle = 0.5 * (min(box.x0 for box in boxes) + max(box.x1 for box in boxes))
    half = 0.5 * text.get_window_extent(figure.canvas.get_renderer()).width / figure.bbox.width
    text.set_x(min(max(middle, half + 0.01), max(0.5, 0.99 - half)))


def headline(figure, text):
    """The title of a whole figure; called when its panels are there. It tells of bodies that are larger than they are."""
    if any(getattr(axes, "dotted", False) for axes in figure.axes):
        text = next((longer for longer in (f"{text} (dots: larger than they are)", f"{text} (as dots)") if LETTER * len(longer)
            < figure.get_figwidth()), text)
    centre(figure, figure.text(0.5, 1 - 0.1 / figure.get_figheight(), text, ha="center", va="top", fontsize=10))


def second_bar(figure, bar, inches=0.86):
    """Axes of another colour bar to the right of the first one."""
    box, shift = bar.get_position(), inches / figure.get_figwidth()
    axes = figure.add_axes([box.x0 + shift, box.y0, box.width, box.height])
    axes.is_bar = True
    return axes


def contain(figure, pad=0.04):
    """Widens a figure in which labels stand out, as far as they do; what is in it keeps its size. pad: inches beyond them."""
    box, (width, height) = figure.get_tightbbox(), figure.get_size_inches()
    left, right = max(0.0, pad - box.x0), max(0.0, box.x1 + pad - width)
    below, above = max(0.0, pad - box.y0), max(0.0, box.y1 + pad - height)
    size = width + left + right, height + below + above
    for axes in figure.axes:
        place = axes.get_position()
        axes.set_position([(place.x0 * width + left) / size[0], (place.y0 * height + below) / size[1],
            place.width * width / size[0], place.height * height / size[1]])
    for text in figure.texts:
        x, y = text.get_position()
        text.set_position(((x * width + left) / size[0], (y * height + below) / size[1]))
    figure.set_size_inches(size)
