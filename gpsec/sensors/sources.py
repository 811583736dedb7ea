"""Where the figures of the profiles come from. What is no published figure begins with 'assumed'."""

OPENCDA = (
    "OpenCDA default.yaml: GNSS noise 1e-6 degrees (0.11 m of latitude), heading 0.1 degrees, "
    "speed 0.2 km/h (0.056 m/s), 20 frames per second"
)
APOLLO = "Wan et al., ICRA 2018 (Baidu Apollo's multi-sensor fusion): 5-10 cm RMS"
NUSCENES = (
    "Caesar et al., CVPR 2020 (nuScenes): GNSS/INS with RTK 20 mm and heading 0.2 degrees, "
    "localization within 10 cm, cameras 12 Hz, front camera 70 degrees wide"
)
RTK = "RTK data sheets: 0.8 cm + 1 ppm of the baseline, which is taken as 10 km, and positions at 10 Hz or more"
DUAL_ANTENNA = "GNSS/INS data sheets (OxTS RT3000, 2 m between the antennas): heading 0.1 degrees"
UBLOX = "u-blox NEO-M8 data sheet: NEO-M8N 5 Hz"
MULTIPATH = "Joerger and Pervan 2020: correlation times of 10-900 s for multipath, 900-2700 s for the troposphere"
STRUCTURE = (
    "√structure function of a public log of a consumer receiver, 11,561 fixes across the way: 0.003, 0.014, 0.055,"
    " 0.093, 0.16, 0.24 m at 0.1, 1, 5, 10, 30, 120 s; fitted by least squares in logarithms"
)
DRIVES = "public logs of two consumer receivers against fused poses: rms of an axis 1.02 and 1.14 m"
STATIC_HOUR = "static hours of a public receiver: about 10 minutes; 180-200 s within a drive"
TWO_RECEIVERS = (
    "GSI Japan, two receivers 3.3 km apart for an hour: correlation 0.82 north, 0.20 east; 0.6-0.9 of the variance is"
    " common nearby"
)
AHRS380 = "gnss-ins-sim, low accuracy (AHRS380): 10 °/h with τ 100 s, 0.75 °/√h"
IMU381 = "gnss-ins-sim, mid accuracy (IMU381): 3.5 °/h with τ 100 s, 0.25 °/√h"
ODOMETER_BEST = (
    "assumed: wheel encoders at a tenth of the noise and, calibrated, half of the scale error of gnss-ins-sim"
)
ODOMETER_WORST = "gnss-ins-sim, odometer of low accuracy: scale 0.99, 0.1 m/s"
MTI_G = "Xsens MTi-G-700 manual MT0605P: yaw 1.0 degree RMS"
OPENPILOT_OFFSET = "openpilot: camera 0.04 m off the centre of the vehicle"
OPENPILOT_TRUST = "openpilot: a lane line is fully used up to σ 0.15 m and not at all above 0.30 m"
LANE_CAMERA_GOOD = "assumed: a third of openpilot's limit of full use, 0.05 m in all, 0.8 of it white and 0.6 bias"
LANE_CAMERA_MEAN = "assumed: between good (0.05 m) and usable (0.15 m) in all, 0.8 of it white and 0.6 bias"
MOBILEYE = "Mobileye, lane detection: markings recognized in over 99 % of cases"
BABIC = "between Mobileye's under 1 % and the 12 % and more of Babić et al., Energies 2021 (rural roads by day): 5 %"
CARLA = "CARLA sensor reference: sensor.camera.rgb is 90 degrees wide by default and synchronous with the step"
AUTOWARE = "Autoware generateFineCenterline: points every 5.0 m by default; the map's own arcs are sparser"
HERE = "HERE lanes, polyline sampling: within 0.10 m of the curve, here held down to a radius of 20 m: √(8·20·0.1) m"
PAPER_MAP = "set-up of the paper that gpsec follows (Chen et al.)"
SIMULATED_SPEED = (
    "CARLA and Driving Scenario Designer: the speed of the vehicle itself, with noise if asked for; no wheel"
)
SIMULATED_MOUNT = "CARLA and Driving Scenario Designer place a camera at the pose that they are given"
SIMULATED_LANE = (
    "MathWorks, visionDetectionGenerator: lane boundaries with added random noise; its size is that of a good camera, "
    "assumed: 0.05 m"
)
SIMULATED_CLOCK = "Driving Scenario Designer: sensors report in the step that they see"

SYNCHRONOUS = "assumed: stamped by hardware, less than a millisecond"
CAN_CYCLE = "assumed: one cycle of a 50 Hz CAN message"
COMMA_LATENCY = "public log of a u-blox M8 against a fused pose (comma2k19): 0.202 s"
COMMA_ODOMETER = "public log (comma2k19): 0.022 m/s white and 0.037 in all, with autocorrelation 0.65 at 0.1 s"
LOGGED_GYROS = "public logs: 48 degrees/h (a car at rest), 120 (comma2k19), 149 (a phone); √(48·149)"
GYRO_REST = "assumed: a bias that zero-speed updates would remove changes with the temperature, over ten minutes"
BERLIN = "public log of an urban canyon (Berlin, single-epoch least squares): across MAD 16 m, p95 65 m"
BERLIN_LENGTH = "the same: 1/e after about 8 s, which at an assumed 8 m/s are 64 m, 0.9 of the side of a square"
INERTIAL_RATE = "assumed: at least 100 Hz, as GNSS/INS and wheel-speed messages have, faster than any loop"
NEVER_OUT = "assumed: outages of this channel are left to attacks and scenarios"
TUNNELS = "assumed: two an hour, under bridges and in short tunnels, 5 s each"
FRAME_AND_A_HALF = "assumed: about a frame and a half at 30 Hz from exposure to lane"
TWO_FRAMES = "assumed: two frames at 20 Hz from exposure to lane"
RECEIVER_LATENCY = "assumed: half of a 5 Hz cycle from epoch to message"
FUSION_TAU = "assumed: the alignment to the map changes within some hundred metres; in the range of Joerger and Pervan"
HEADING_TAU = "assumed: that of the gyro's bias, which drives it"
HEADING_SPLIT = "assumed: a fifth of the total is white"
PAINT_TAU = "assumed: the paint of 150-300 m of road"
RENDERED_TAU = (
    "rendered pictures (tapes rendered-good to rendered-worn): autocorrelation of C0 0.4-0.5 after 0.5 s and 0.1-0.3 "
    "after 2 s; with a memory 1.0-1.2 s"
)
RENDERED_TAILS = (
    "rendered pictures (tapes rendered-good to rendered-worn): kurtosis 7-10, which is that of 5 % three times as wide"
)
RENDERED_SLOPE = "rendered pictures (tapes rendered-good to rendered-worn): correlation of C0 and C1 -0.91"
RENDERED_WORN = (
    "rendered pictures of worn paint (tape rendered-worn): 0.065 m in all, a ninth of the variance gone after 0.1 s"
)
RENDERED_GAPS = "rendered pictures (tapes): 6 % more of the frames are lost with worn paint than with good; 5 % here"
PAINT_GAP = "assumed: worn or hidden for 1 s, about 15-30 m"
PAINT_GAP_LONG = "assumed: worn or hidden for 2 s, about 30-60 m"
LANE_RANGE = "assumed: the part of the road that a lane camera fits well, well within its view"
SERIES_LENS = "assumed: lens of a current series camera"
NARROW_LENS = "assumed: lens of the first generation of series cameras"
