# What a type checker sees of the names that __init__.py imports when they are first used.
from solarcal.library import Analysis as Analysis
from solarcal.library import Forecast as Forecast
from solarcal.library import Mechanism as Mechanism
from solarcal.library import MountGeometry as MountGeometry
from solarcal.library import Points as Points
from solarcal.library import Site as Site
from solarcal.library import Solution as Solution
from solarcal.library import SunPosition as SunPosition
from solarcal.library import Weather as Weather
from solarcal.library import analyse as analyse
from solarcal.library import fit as fit
from solarcal.library import forecast as forecast
from solarcal.library import read as read
from solarcal.library import sun_position as sun_position

__version__: str
_OFFERED: tuple[str, ...]
