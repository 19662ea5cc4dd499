"""glue-factory's relative pose by diffsac: copied to gluefactory/robust_estimators/relative_pose/diffsac.py (docs/drop_ins.md),
`eval.estimator=diffsac` then runs it. A matcher's `m_matching_scores` (`matching_scores0` of the matches) are used where they are given."""

import torch
from omegaconf import OmegaConf

from diffsac.poselib import estimate_relative_pose

from ...geometry.wrappers import Pose
from ..base_estimator import BaseEstimator


class DiffsacRelativePoseEstimator(BaseEstimator):
    default_conf = {"ransac_th": 1.0, "options": {}}

    required_data_keys = ["m_kpts0", "m_kpts1", "camera0", "camera1"]

    def _init(self, conf):
        pass

    def _forward(self, data):
        points, scores = data["m_kpts0"], data.get("m_scores")
        pose, info = estimate_relative_pose(
            points.numpy(),
            data["m_kpts1"].numpy(),
            data["camera0"].to_cameradict(),
            data["camera1"].to_cameradict(),
            {"max_error": self.conf.ransac_th},
            scores=None if scores is None else scores.numpy(),
            **OmegaConf.to_container(self.conf.options),
        )
        success = info.pop("estimate").ok
        motion = Pose.from_Rt(torch.tensor(pose.R), torch.tensor(pose.t)) if success else Pose.from_4x4mat(torch.eye(4))
        return {"success": success, "M_0to1": motion.to(points), "inliers": torch.tensor(info.pop("inliers")).to(points), **info}
