"""Glass: materials that light goes through."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

from bobrossnet import _core
from bobrossnet.color import Color, linear
from bobrossnet.support.errors import check_flag, check_number
from bobrossnet.tracing.material import Material


@dataclass(frozen=True, init=False)
class Glass(Material):
    """A solid that reflects and refracts light, such as glass or water; or a sheet, such as a window pane.

    The shape of a solid encloses the glass. Solids may overlap: the one that a ray entered last counts, so that water
    may reach into its glass. Only `light` shows it; under the headlight it is opaque.

    Parameters
    ----------
    color : like a material's
        By which light is multiplied: once for each solid that it enters, and at each sheet.
    ior : float in 1..100
        Index of refraction: 1.33 of water, 1.5 of glass, 2.42 of diamond.
    roughness : float in 0..1
        As a material's; 0 is polished.
    attenuation : like color
        What white light has become after `distance` inside: Beer's law.
    distance : float above 0
        In the scene's units.
    transmission : float in 0..1
        Share of the light that goes in; the rest meets a body like plastic.
    thin : bool
        Whether the surface is a sheet: light goes straight on, and `attenuation` has no effect. Its shape may be open.
    emissive : like color
        As a material's.

    Raises
    ------
    InputError
        If a value is out of range or not a number.

    Examples
    --------
    >>> import bobrossnet as bob
    >>> bottle = bob.Glass(attenuation="#4a7", distance=0.5)
    >>> picture = bob.render(bob.Instance(bob.happy_tree(), material=bottle), size="80x60", light="studio", samples=1)
    """

    transmission: float
    ior: float
    attenuation: tuple[float, float, float]
    """Linear RGB, 0..1."""
    distance: float
    thin: bool

    def __init__(
        self,
        color: Color = (1.0, 1.0, 1.0),
        *,
        ior: float = 1.5,
        roughness: float = 0.0,
        attenuation: Color = (1.0, 1.0, 1.0),
        distance: float = inf,
        transmission: float = 1.0,
        thin: bool = False,
        emissive: Color = (0.0, 0.0, 0.0),
    ) -> None:
        super().__init__(color, metallic=0, roughness=roughness, emissive=emissive)
        for name, value in (
            ("transmission", check_number("transmission", transmission, 0, 1)),
            ("ior", check_number("ior", ior, 1, _core.MAX_IOR)),
            ("attenuation", linear("attenuation", attenuation)),
            (
                "distance",
                inf
                if isinstance(distance, float) and distance == inf
                else check_number("distance", distance, 0, above=True),
            ),
            ("thin", check_flag("thin", thin)),
        ):
            object.__setattr__(self, name, value)

    @property
    def is_white(self) -> bool:
        return super().is_white and self.attenuation == (1, 1, 1)

    def core(self) -> _core.Material:
        """The material in the core."""
        assert self.metallic is not None
        assert self.roughness is not None
        return _core.Material(
            self.color, self.ambient, self.diffuse, self.specular, self.shininess, self.metallic, self.roughness,
            self.emissive, self.clearcoat, self.clearcoat_roughness,
            self.transmission, self.ior, self.attenuation, self.distance, self.thin,
        )  # fmt: skip
