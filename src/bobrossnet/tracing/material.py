"""Materials: the reflection of light by surfaces."""

from __future__ import annotations

from dataclasses import asdict, dataclass

from bobrossnet import _core
from bobrossnet.color import Color, linear
from bobrossnet.support.errors import InputError, check_number


@dataclass(frozen=True, init=False)
class Material:
    """Reflection of a surface, by Blinn-Phong or by glTF 2.0's metallic-roughness model.

    docs/reference/shading.md has the formulas.

    Parameters
    ----------
    color : 3 numbers in 0..1, or str
        Linear RGB; or sRGB as "#rrggbb", "#rgb" or a CSS color name, which is converted to linear. A shape's own
        colours are multiplied by it.
    ambient, diffuse, specular : float in 0..1
        Blinn-Phong: weight of each term.
    shininess : float in 0..10000
        Blinn-Phong: exponent of the highlight.
    metallic, roughness : float in 0..1, optional
        Either of them selects glTF's model; the other defaults to 0, or 0.5 for roughness. Metals reflect in
        their colour, dielectrics in white; rougher surfaces have wider highlights.
    emissive : like color
        Emitted light, added to the reflected light.
    clearcoat, clearcoat_roughness : float in 0..1
        Varnish on the surface, of index 1.5: its amount and roughness. Only lights show it.

    Raises
    ------
    InputError
        If a value is out of range or not a number, or values of both models are mixed.

    Examples
    --------
    >>> import bobrossnet as bob
    >>> copper = bob.Material(color="#b87333", metallic=1, roughness=0.3)
    >>> scene = bob.Scene(bob.Instance(bob.happy_tree(), material=copper))
    >>> bob.trace(scene, size=(60, 80)).color.shape
    (60, 80, 3)
    """

    color: tuple[float, float, float]
    """Linear RGB, 0..1."""
    ambient: float
    diffuse: float
    specular: float
    shininess: float
    metallic: float | None
    """Whether every Blinn-Phong parameter is omitted."""
    roughness: float | None
    emissive: tuple[float, float, float]
    """Linear RGB, 0..1."""
    clearcoat: float
    clearcoat_roughness: float

    def __init__(
        self,
        color: Color = (1.0, 1.0, 1.0),
        ambient: float = 0.1,
        diffuse: float = 0.7,
        specular: float = 0.2,
        shininess: float = 32.0,
        metallic: float | None = None,
        roughness: float | None = None,
        emissive: Color = (0.0, 0.0, 0.0),
        clearcoat: float = 0.0,
        clearcoat_roughness: float = 0.0,
    ) -> None:
        if metallic is not None or roughness is not None:
            if (ambient, diffuse, specular, shininess) != (0.1, 0.7, 0.2, 32.0):
                raise InputError(
                    "material: expected metallic and roughness, or ambient, diffuse, specular and shininess, got both"
                )
            metallic = check_number("metallic", 0.0 if metallic is None else metallic, 0, 1)
            roughness = check_number("roughness", 0.5 if roughness is None else roughness, 0, 1)
        for name, value in (
            ("color", linear("color", color)),
            ("ambient", check_number("ambient", ambient, 0, 1)),
            ("diffuse", check_number("diffuse", diffuse, 0, 1)),
            ("specular", check_number("specular", specular, 0, 1)),
            ("shininess", check_number("shininess", shininess, 0, 10_000)),
            ("metallic", metallic),
            ("roughness", roughness),
            ("emissive", linear("emissive", emissive)),
            ("clearcoat", check_number("clearcoat", clearcoat, 0, 1)),
            ("clearcoat_roughness", check_number("clearcoat_roughness", clearcoat_roughness, 0, 1)),
        ):
            object.__setattr__(self, name, value)

    @property
    def is_white(self) -> bool:
        """Whether the reflected light is gray under white light."""
        return self.color == (1, 1, 1) and self.emissive == (0, 0, 0)

    def core(self) -> _core.Material:
        """Return the core's material."""
        fields = asdict(self)
        if self.roughness is None:
            fields |= {"metallic": 0, "roughness": -1}
        return _core.Material(**fields)
