//! The sets of recordings, and what is asked of each.

mod balloon;
mod boulder;
mod by_magnitude;
mod certificates;
mod coil;
mod pair;
mod pairs;
mod rotations;
mod scalar;
mod scalars;
mod station;
mod turned;

use super::page::Page;
use super::stages::Stages;
use crate::Error;

/// One question to one set.
#[derive(Clone, Copy, Debug)]
pub struct Set {
    /// Name on the command line.
    pub name: &'static str,
    /// Folder of the recordings.
    pub folder: &'static str,
    /// What is asked.
    pub title: &'static str,
    /// Where the recordings come from.
    pub source: &'static str,
    /// Asks it.
    pub run: fn(&Stages) -> Result<Page, Error>,
}

const MAGPY: &str = "Cobenzl, by the history of github.com/geomagpy/magpy (GPL-3 at that commit)";
const CONRAD: &str =
    "Conrad Observatory, GeoSphere Austria (CC-BY-4.0), by the test data of github.com/geomagpy/magpy";
const USGS: &str = "U.S. Geological Survey, Boulder, by github.com/usgs/geomag-algorithms (public domain)";
const TUCAN: &str = "github.com/ucn-triumf/gradiometer (no licence stated; figures only)";
const MXL: &str =
    "github.com/apujara22/MagCal_W25_MXL, University of Michigan (no licence stated; figures only)";

/// All sets, in the order of the page.
pub const SETS: &[Set] = &[
    Set {
        name: "conrad-pair",
        folder: "wic-conrad-2022-08",
        title: "Conrad: a suspended fluxgate predicts another 200 m away",
        source: CONRAD,
        run: pairs::conrad,
    },
    Set {
        name: "cobenzl-pair",
        folder: "wik-cobenzl-2011-09a",
        title: "Cobenzl: eight quiet days predict a magnetic storm",
        source: MAGPY,
        run: pairs::cobenzl,
    },
    Set {
        name: "meson-hall",
        folder: "tucan-fluxgates-2019-08-09-quiet",
        title: "Meson Hall: two fluxgates that share no field",
        source: "github.com/jmartin1454/tucan-magnetics-mapping-201908 (no licence stated; figures only)",
        run: pairs::meson_hall,
    },
    Set {
        name: "quadrotor",
        folder: "mxl-quadrotor-2021-04-23",
        title: "A quadrotor turned by hand: two magnetometers on one frame",
        source: MXL,
        run: pairs::quadrotor,
    },
    Set {
        name: "balloon",
        folder: "mxl-balloon-2025-02-22a",
        title: "A balloon to −32 °C: is it the temperature or the time?",
        source: MXL,
        run: balloon::run,
    },
    Set {
        name: "boulder-published",
        folder: "usgs-bou-2016-01",
        title: "Boulder: the observatory's own matrix",
        source: USGS,
        run: boulder::published,
    },
    Set {
        name: "boulder-2016",
        folder: "usgs-bou-2016-01",
        title: "Boulder 2016: a vector against a scalar magnetometer, 29 days",
        source: USGS,
        run: boulder::month,
    },
    Set {
        name: "boulder-2014",
        folder: "usgs-bou-2014-11",
        title: "Boulder 2014: a vector against a scalar magnetometer, a storm held out",
        source: USGS,
        run: boulder::storm,
    },
    Set {
        name: "conrad-scalar",
        folder: "wic-conrad-2022-08",
        title: "Conrad: one day's vector and scalar predict another day's",
        source: CONRAD,
        run: scalars::conrad,
    },
    Set {
        name: "vernadsky",
        folder: "aia-vernadsky-2020-03-03",
        title: "Vernadsky: LEMI-025 against a scalar magnetometer",
        source: "Argentine Islands, by the test data of github.com/geomagpy/magpy (BSD-3-Clause)",
        run: scalars::vernadsky,
    },
    Set {
        name: "cobenzl-scalar",
        folder: "wik-cobenzl-2011-09a",
        title: "Cobenzl: a proton magnetometer whose clock is doubtful",
        source: MAGPY,
        run: scalars::cobenzl,
    },
    Set {
        name: "w2naf",
        folder: "hamsci-w2naf-2024-05-10",
        title: "W2NAF: an RM3100 by itself, two temperatures, the storm of May 2024",
        source: "github.com/HamSCI/mag_lab (GPL-3.0)",
        run: station::w2naf,
    },
    Set {
        name: "marg-static",
        folder: "marg-hmc5883l-sunsided",
        title: "HMC5883L lying still for ten minutes, with a temperature",
        source: "github.com/sunsided/sensor-fusion (EUPL-1.2)",
        run: station::marg,
    },
    Set {
        name: "marg-rotations",
        folder: "marg-hmc5883l-sunsided",
        title: "HMC5883L turned by hand: one run predicts another",
        source: "github.com/sunsided/sensor-fusion (EUPL-1.2)",
        run: rotations::marg,
    },
    Set {
        name: "phone",
        folder: "phone-vn100-rotations",
        title: "A phone and a VN-100 turned by hand, iron near by",
        source: "github.com/howe-mal/Magnetometer-Comparison-Project (no licence stated; figures only)",
        run: rotations::phone,
    },
    Set {
        name: "marg-scalarcal",
        folder: "marg-hmc5883l-sunsided",
        title: "HMC5883L turned by hand: scalarcal",
        source: "github.com/sunsided/sensor-fusion (EUPL-1.2)",
        run: by_magnitude::marg,
    },
    Set {
        name: "phone-scalarcal",
        folder: "phone-vn100-rotations",
        title: "A phone and a VN-100 turned by hand: scalarcal",
        source: "github.com/howe-mal/Magnetometer-Comparison-Project (no licence stated; figures only)",
        run: by_magnitude::phone,
    },
    Set {
        name: "quadrotor-scalarcal",
        folder: "mxl-quadrotor-2021-04-23",
        title: "A quadrotor and a balloon turned by hand: scalarcal",
        source: MXL,
        run: by_magnitude::michigan,
    },
    Set {
        name: "square-wave",
        folder: "tucan-coil-tests",
        title: "A coil driven by a square wave: a fault that is known is found unasked",
        source: TUCAN,
        run: coil::square_wave,
    },
    Set {
        name: "gradiometer",
        folder: "tucan-coil-tests",
        title: "Scans along a gradiometer: a magnetised foil against the empty holder",
        source: TUCAN,
        run: coil::gradiometer,
    },
    Set {
        name: "certificates",
        folder: "geonet-fge-constants",
        title: "Certificates of four observatory fluxgates",
        source: "GeoNet, github.com/GeoNet/delta (Apache-2.0)",
        run: certificates::run,
    },
];
