"""What a rotctld says of itself, in its extended protocol."""

STATE = (
    "dump_state:",
    "rotctld Protocol Ver: 1",
    "Rotor Model: 603",
    "Minimum Azimuth: 0.000000",
    "Maximum Azimuth: 450.000000",
    "Minimum Elevation: 0.000000",
    "Maximum Elevation: 180.000000",
    "South Zero: 0",
    "rot_type=AzEl",
    "done",
    "RPRT 0",
)
CAPS = (
    "dump_caps:",
    "Caps dump for model:\t603",
    "Model name:\t\tGS-232B",
    "Mfg name:\t\tYaesu",
    "Backend version:\t20220109.0",
    "Rot type:\t\tAz-El",
    "Can Stop:\t\tY",
    "RPRT 0",
)
AT_REST = ("get_pos:", "Azimuth: 180.00", "Elevation: 45.00", "RPRT 0")
OPENING = (
    ("+\\dump_state", *STATE),
    ("+\\dump_caps", *CAPS),
    ("+\\get_pos", *AT_REST),
)
