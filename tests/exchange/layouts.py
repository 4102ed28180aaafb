"""One small layout in four forms: a line from an open end over a loop to a buffer stop, with a siding of its own.

    0 ---- main, 1000 m ---- P1 ==== track 1, 400 m ==== P2 ---- 600 m ---- 2000 (buffer stop)
                                ==== track 2, 404 m ====

Birch stands at km 1.2 with a platform on each of its tracks, Cedar at km 1.9.
"""

from collections.abc import Callable
from pathlib import Path

from network.errors import InputError

RAILML_2 = """<?xml version="1.0" encoding="UTF-8"?>
<railml xmlns="https://www.railml.org/schemas/2018" version="2.4">
  <infrastructure id="is" name="Small">
    <tracks>
      <track id="tm" name="1" type="mainTrack">
        <trackTopology>
          <trackBegin id="b1" pos="0" absPos="0"><openEnd id="o1"/></trackBegin>
          <trackEnd id="e1" pos="2000" absPos="2000"><bufferStop id="u1"/></trackEnd>
          <connections>
            <switch id="s1" name="P1" pos="1000" trackContinueCourse="straight">
              <connection id="c1" ref="k1" course="right" orientation="outgoing" maxSpeed="35"/>
            </switch>
            <switch id="s2" name="P2" pos="1400" trackContinueCourse="straight" type="ordinarySwitch">
              <connection id="c2" ref="k2" course="right" orientation="incoming" maxSpeed="35"/>
            </switch>
          </connections>
          <crossSections>
            <crossSection id="x1" pos="1200" ocpRef="birch"/>
            <crossSection id="x2" pos="1900" ocpRef="cedar"/>
          </crossSections>
        </trackTopology>
        <trackElements>
          <platformEdges>
            <platformEdge id="p1" pos="1150" length="80" ocpRef="birch"/>
            <platformEdge id="p3" pos="1880" length="60" ocpRef="cedar"/>
          </platformEdges>
          <speedChanges><speedChange id="v1" pos="0" vMax="60" dir="up"/></speedChanges>
        </trackElements>
        <ocsElements>
          <signals>
            <signal id="g1" name="A" pos="900" dir="up"/>
            <signal id="g2" name="B" pos="1500" dir="down"/>
          </signals>
          <derailers><derailer id="d1" pos="1010"/></derailers>
        </ocsElements>
      </track>
      <track id="ts" name="2" type="secondaryTrack">
        <trackTopology>
          <trackBegin id="b2" pos="0" absPos="1000"><connection id="k1" ref="c1"/></trackBegin>
          <trackEnd id="e2" pos="404" absPos="1400"><connection id="k2" ref="c2"/></trackEnd>
          <crossSections><crossSection id="x3" pos="202" ocpRef="birch"/></crossSections>
        </trackTopology>
        <trackElements>
          <platformEdges><platformEdge id="p2" pos="150" length="80" ocpRef="birch"/></platformEdges>
        </trackElements>
      </track>
    </tracks>
    <operationControlPoints>
      <ocp id="birch" name="Birch"><designator register="R" entry="BIR"/></ocp>
      <ocp id="cedar" name="Cedar"/>
    </operationControlPoints>
  </infrastructure>
</railml>
"""


def _element(name: str, length_m: float, from_m: float, to_m: float) -> str:
    return f"""
      <netElement id="{name}" length="{length_m}">
        <associatedPositioningSystem id="{name}_a">
          <intrinsicCoordinate id="{name}_0" intrinsicCoord="0">
            <linearCoordinate positioningSystemRef="l" measure="{from_m}"/></intrinsicCoordinate>
          <intrinsicCoordinate id="{name}_1" intrinsicCoord="1">
            <linearCoordinate positioningSystemRef="l" measure="{to_m}"/></intrinsicCoordinate>
        </associatedPositioningSystem>
      </netElement>"""


def _relation(name: str, one: str, at_one: int, other: str, at_other: int, navigable: str = "Both") -> str:
    return f"""
      <netRelation id="{name}" navigability="{navigable}" positionOnA="{at_one}" positionOnB="{at_other}">
        <elementA ref="{one}"/><elementB ref="{other}"/></netRelation>"""


def _spot(element: str, pos_m: float, direction: str = "both") -> str:
    return (
        f'<spotLocation id="q_{element}_{pos_m}" netElementRef="{element}" pos="{pos_m}"'
        f' applicationDirection="{direction}"/>'
    )


RAILML_3 = f"""<?xml version="1.0" encoding="UTF-8"?>
<railML xmlns="https://www.railml.org/schemas/3.2" xmlns:dc="http://purl.org/dc/elements/1.1/" version="3.2">
  <metadata><dc:title>Small</dc:title></metadata>
  <infrastructure id="is">
    <topology>
      <netElements>{_element("na", 1000, 0, 1000)}{_element("nb", 400, 1000, 1400)}
        {_element("nc1", 250, 1400, 1650)}{_element("nc2", 350, 1650, 2000)}{_element("nd", 404, 1000, 1400)}
        <netElement id="meso"><elementCollectionUnordered id="m"><elementPart ref="nb"/></elementCollectionUnordered>
        </netElement>
      </netElements>
      <netRelations>{_relation("r1", "na", 1, "nb", 0)}{_relation("r2", "na", 1, "nd", 0)}
        {_relation("r3", "nb", 0, "nd", 0, "None")}{_relation("r4", "nb", 1, "nc1", 0)}
        {_relation("r5", "nd", 1, "nc1", 0)}{_relation("r6", "nb", 1, "nd", 1, "None")}
        {_relation("r7", "nc1", 1, "nc2", 0)}
      </netRelations>
    </topology>
    <functionalInfrastructure>
      <borders><border id="o1" isOpenEnd="true">{_spot("na", 0)}</border></borders>
      <bufferStops><bufferStop id="u1">{_spot("nc2", 350)}</bufferStop></bufferStops>
      <derailersIS><derailerIS id="d1">{_spot("nb", 10)}</derailerIS></derailersIS>
      <operationalPoints>
        <operationalPoint id="birch"><name name="Birch" language="en"/>{_spot("nb", 200)}{_spot("nd", 202)}
          <designator register="R" entry="BIR"/>
          <opEquipment><ownsPlatform ref="p1"/><ownsPlatform ref="p2"/></opEquipment></operationalPoint>
        <operationalPoint id="cedar"><name name="Cedar" language="en"/>{_spot("nc2", 250)}
          <opEquipment><ownsPlatform ref="p3"/></opEquipment></operationalPoint>
      </operationalPoints>
      <platformEdges>
        <platformEdge id="p1"><linearLocation id="z1">
          <associatedNetElement netElementRef="nb" posBegin="150" posEnd="230"/></linearLocation></platformEdge>
        <platformEdge id="p2"><linearLocation id="z2">
          <associatedNetElement netElementRef="nd" posBegin="230" posEnd="150"/></linearLocation></platformEdge>
        <platformEdge id="p3"><linearLocation id="z3">
          <associatedNetElement netElementRef="nc2" posBegin="230" posEnd="290"/></linearLocation></platformEdge>
      </platformEdges>
      <signalsIS>
        <signalIS id="g1"><name name="A" language="en"/>{_spot("na", 900, "normal")}</signalIS>
        <signalIS id="g2"><name name="B" language="en"/>{_spot("nc1", 100, "reverse")}</signalIS>
        <signalIS id="g3">{_spot("nb", 5, "normal")}<isStopPost/></signalIS>
      </signalsIS>
      <speeds><speedSection id="v1" maxSpeed="60"/></speeds>
      <switchesIS>
        <switchIS id="s1" type="ordinarySwitch" branchCourse="right" continueCourse="left">
          <name name="P1" language="en"/>{_spot("nb", 0, "normal")}
          <leftBranch netRelationRef="r1" branchingSpeed="35"/><rightBranch netRelationRef="r2" branchingSpeed="35"/>
        </switchIS>
        <switchIS id="s2" type="ordinarySwitch" branchCourse="left" continueCourse="right">
          <name name="P2" language="en"/>{_spot("nc1", 0, "reverse")}
          <leftBranch netRelationRef="r5" branchingSpeed="35"/><rightBranch netRelationRef="r4" branchingSpeed="35"/>
        </switchIS>
      </switchesIS>
      <tracks>
        <track id="t1" type="mainTrack"><name name="1" language="en"/><linearLocation id="w1">
          <associatedNetElement netElementRef="na"/><associatedNetElement netElementRef="nb"/>
          <associatedNetElement netElementRef="nc1"/><associatedNetElement netElementRef="nc2"/>
        </linearLocation></track>
        <track id="t2" type="secondaryTrack"><name name="2" language="en"/><linearLocation id="w2">
          <associatedNetElement netElementRef="nd"/></linearLocation></track>
      </tracks>
    </functionalInfrastructure>
  </infrastructure>
</railML>
"""

# On the equator, where a degree is as long in both directions: 0.00001 degrees are 1.113 m (1.106 m to the north).
DEGREE_EAST_M = 111_319.49
DEGREE_NORTH_M = 110_574.28


def osm_node(node: int, east_m: float, north_m: float, **tags: str) -> str:
    """A node at a place on the plane about 0 N 10 E."""
    lon, lat = 10.0 + east_m / DEGREE_EAST_M, north_m / DEGREE_NORTH_M
    inside = "".join(f'<tag k="{key.replace("__", ":")}" v="{value}"/>' for key, value in tags.items())
    return f'<node id="{node}" lon="{lon:.9f}" lat="{lat:.9f}">{inside}</node>'


def osm_way(way: int, nodes: list[int], **tags: str) -> str:
    """A way over nodes; a rail if nothing else is said."""
    inside = "".join(f'<nd ref="{node}"/>' for node in nodes)
    inside += "".join(f'<tag k="{key}" v="{value}"/>' for key, value in ({"railway": "rail"} | tags).items())
    return f'<way id="{way}">{inside}</way>'


OSM = "\n".join(
    (
        '<?xml version="1.0" encoding="UTF-8"?><osm version="0.6">',
        osm_node(1, 0, 0),
        osm_node(2, 500, 0, railway="milestone", railway__position="0.5"),
        osm_node(3, 700, 0, railway="milestone", railway__position="0,7"),
        osm_node(4, 1000, 0, railway="switch", ref="P1"),
        osm_node(5, 1200, 0, railway="stop", name="Birch", local_ref="1"),
        osm_node(6, 1400, 0, railway="switch", ref="P2", railway__position="7.7"),
        osm_node(7, 1900, 0, railway="halt", name="Cedar"),
        osm_node(8, 2000, 0, railway="buffer_stop"),
        osm_node(9, 1050, -4),
        osm_node(10, 1200, -4, railway="stop", name="Birch", local_ref="2"),
        osm_node(11, 1350, -4),
        osm_node(12, 900, 0, railway="signal", ref="A", railway__signal__direction="forward"),
        osm_node(13, 1200, 40, railway="station", name="Birch", railway__ref="BIR"),
        osm_node(14, 600, 0, railway="level_crossing"),
        osm_node(15, 1500, 0, railway="signal", ref="B", railway__signal__direction="backward"),
        osm_way(1, [1, 2, 14, 3], ref="7", usage="branch"),
        osm_way(2, [3, 12, 4, 5, 6], ref="7", usage="branch", maxspeed="60"),
        # Drawn against the line.
        osm_way(3, [8, 7, 15, 6], ref="7", usage="branch"),
        osm_way(4, [4, 9, 10, 11, 6], service="siding"),
        osm_way(5, [1, 13], railway="abandoned"),
        "</osm>",
    )
)


def leave_out_each_line(text: str, file: Path, read: Callable[[Path], object]) -> None:
    """No damage of one line is a bug: the layout lacks it, or one message says what is missing."""
    lines = text.split("\n")
    for number in range(1, len(lines) - 1):
        file.write_text("\n".join(lines[:number] + lines[number + 1 :]), "utf-8")
        try:
            read(file)
        except InputError as error:
            assert "\n" not in str(error)
