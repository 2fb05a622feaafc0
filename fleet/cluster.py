"""A cluster on this machine, for tests and measurements."""

import os
import signal
import socket
import subprocess
import sys
import time

HERE = os.path.dirname(os.path.abspath(__file__))


class Cluster:
    """A standalone master with workers of one core."""

    def __init__(self, folder, workers=2):
        import pyspark

        self.spark = os.path.join(os.path.dirname(pyspark.__file__), "bin", "spark-class")
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.port = free.getsockname()[1]
        self.master = f"spark://127.0.0.1:{self.port}"
        self.environment = {
            **os.environ,
            "SPARK_DAEMON_MEMORY": "512m",
            "SPARK_LOCAL_IP": "127.0.0.1",
            "PYSPARK_PYTHON": sys.executable,
            "PYSPARK_DRIVER_PYTHON": sys.executable,
        }
        self.log = open(os.path.join(folder, "cluster.log"), "ab")
        self.started = [self.start("master.Master", "--host", "127.0.0.1", "--port", str(self.port), "--webui-port", "0")]
        deadline = time.monotonic() + 120
        while socket.socket().connect_ex(("127.0.0.1", self.port)) != 0:
            assert time.monotonic() < deadline, "the master does not listen"
            time.sleep(0.2)
        for number in range(workers):
            work = os.path.join(folder, f"worker-{self.port}-{number}")
            worker = self.start("worker.Worker", "--cores", "1", "--memory", "1g", "--webui-port", "0", "--work-dir", work, self.master)
            self.started.append(worker)

    def start(self, name, *arguments):
        command = [self.spark, f"org.apache.spark.deploy.{name}", *arguments]
        # A process group of its own, so that a worker goes with its executors.
        return subprocess.Popen(command, env=self.environment, stdout=self.log, stderr=self.log, start_new_session=True)

    def lose_a_worker(self):
        os.killpg(self.started[2].pid, signal.SIGKILL)

    def run(self, *arguments):
        """Submits the job, or another file of this folder."""
        options = ["--master", self.master, "--conf", "spark.executor.memory=512m", "--conf", "spark.ui.enabled=false"]
        submit = os.path.join(os.path.dirname(self.spark), "spark-submit")
        command = [submit, *options, os.path.join(HERE, arguments[0]), *arguments[1:]]
        done = subprocess.run(command, env=self.environment, capture_output=True, text=True)
        assert done.returncode == 0, (done.stderr + done.stdout)[-6000:]
        return done

    def stop(self):
        for process in reversed(self.started):
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGTERM)
        for process in self.started:
            process.wait()
        self.log.close()
