"""Recorded traffic of the training networks: simulated once, and kept for every model, command and run after it."""

import hashlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

from gpsec.core import shipped
from gpsec.core.caches import cache_folder, can_keep
from gpsec.core.sources import digest
from gpsec.traffic.input_files import input_files
from gpsec.traffic.options import resolve_options
from gpsec.traffic.recording import Recording
from gpsec.training.collect import record_scenario, recorded_traffic
from gpsec.training.pool import Call, Pool


@dataclass(frozen=True)
class Recordings:
    """Recordings of networks and seeds in a folder, as ``<network>-<seed>-<digest>.npz``.

    The digest is of what SUMO reads, of its version, and of the code that reads SUMO, so that a recording of another
    traffic is never taken for this one.

    Attributes:
        folder: where they lie.
        digests: of each network.
        nets: net file of each network.
    """

    folder: Path
    digests: dict[str, str]
    nets: dict[str, Path]

    @classmethod
    def of(cls, networks: Sequence[str], otherwise: Path) -> "Recordings":
        """Return the recordings of shipped networks, which need not be there yet.

        They are kept in gpsec's cache, or in the folder `otherwise` where that cannot be written.

        Raises:
            GpsecError: somebody else can change what is in the cache.
        """
        kept = cache_folder() / "traffic"
        folder = kept if can_keep(kept) else otherwise
        options = {network: resolve_options(_config(network), seed=1) for network in networks}
        digests = {
            network: _digest([_config(network), one.net_file, *one.route_files, *one.additional_files])
            for network, one in options.items()
        }
        return cls(folder, digests, {network: one.net_file for network, one in options.items()})

    def record(self, seeds: Iterable[int], pool: Pool) -> None:
        """Record what is not there yet, each in a process of the pool; what is of another traffic goes."""
        self.folder.mkdir(parents=True, exist_ok=True)
        seeds = sorted(set(seeds))
        missing: list[Call] = [
            (network, record_scenario, (_config(network), seed, self._path(network, seed)))
            for network in self.nets
            for seed in seeds
            if not self._path(network, seed).exists()
        ]
        if missing:
            pool.run("traffic", missing)
        for network in self.nets:
            for seed in seeds:
                for former in self.folder.glob(f"{network}-{seed}-*.npz"):
                    if former != self._path(network, seed):
                        former.unlink(missing_ok=True)

    def read(self, network: str, seed: int) -> Recording:
        """Return a recording.

        Raises:
            GpsecError: it is damaged.
        """
        return recorded_traffic(self._path(network, seed), self.nets[network])

    def _path(self, network: str, seed: int) -> Path:
        return self.folder / f"{network}-{seed}-{self.digests[network]}.npz"


def _config(network: str) -> Path:
    return shipped.scenarios() / network / f"{network}.sumocfg"


def _digest(files: Sequence[Path]) -> str:
    total = hashlib.sha256(f"libsumo {version('libsumo')} {digest('gpsec.traffic')}".encode())
    for path in input_files(files):
        total.update(hashlib.sha256(path.read_bytes()).digest())
    return total.hexdigest()[:12]
